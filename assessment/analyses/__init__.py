"""The analyses that a project asks for, as plain numbers for the results."""
