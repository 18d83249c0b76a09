"""Folders on disk: demonstrations, a training, a finished study, violations of a net, flights in a lab."""
