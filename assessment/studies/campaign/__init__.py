"""Campaigns: records x movements x shares x signs, fragility and loss of capacity against movement."""
