"""What single chapters of the report say: sentences that follow from the results."""
