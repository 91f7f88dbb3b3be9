"""The content of single chapters of the report: sentences and tables that follow from the results."""
