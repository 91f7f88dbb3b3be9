"""What is measured: a module for each question, and the structures they share."""
