"""From loop tests to a law and on to co-simulation; the command line is the top."""
