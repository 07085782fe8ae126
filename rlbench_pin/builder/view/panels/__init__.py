"""The panels of the page: functions from what is being edited to items."""
