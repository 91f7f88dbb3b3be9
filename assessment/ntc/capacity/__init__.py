"""The capacity of a mechanism: the pushover curve fitted, its oscillator, and the return period that it bears."""
