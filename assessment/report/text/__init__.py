"""The words of the report in Italian and English, and how numbers are written."""
