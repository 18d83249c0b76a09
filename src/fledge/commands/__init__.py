"""What may be typed: a function per command, and the options they share."""
