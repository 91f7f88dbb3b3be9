"""Settlements and pushover of every state."""
