"""fledge."""
