"""Files of an output folder: written whole, swapped together, locked, and the journal of a run."""
