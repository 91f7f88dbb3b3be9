"""The tables of the report and of the CSV files."""
