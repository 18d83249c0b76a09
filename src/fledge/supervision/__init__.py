"""Layer two of the safety net: who flies each vehicle, and what may be believed, decided anew every tick."""
