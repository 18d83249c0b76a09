"""Where the lab meets the machine: sockets, topics, terminals, clocks, logs, and the loops around both ends."""
