"""The cockpit: a person flies, demonstrates, watches and takes over, in a browser."""
