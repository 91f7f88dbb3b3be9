"""The forms in which a report leaves the program: page, PDF, Word, pictures attached to it."""
