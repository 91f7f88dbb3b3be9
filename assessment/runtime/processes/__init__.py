"""Processes that compute side by side, on this machine or on a cluster; how they are interrupted."""
