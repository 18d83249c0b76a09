"""Attacks on a safety net: adversaries, the vehicles under attack, and campaigns of them by the thousand."""
