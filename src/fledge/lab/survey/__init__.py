"""From logs of flights to what a vehicle of one's own can do, and the net may count on."""
