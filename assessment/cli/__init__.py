"""The command line `assesto`: arguments, exit codes, and what the terminal shows."""
