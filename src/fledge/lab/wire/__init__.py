"""What travels: datagrams, and codecs that are pure, never raise on bytes, and know nothing of each other."""
