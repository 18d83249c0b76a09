"""The controller: from datagrams to datagrams, 100 times a second, without a clock or a socket."""
