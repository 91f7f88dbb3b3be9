"""The report, its page and its files: functions of the results."""
