"""Tables of the structure: loads, joints and their cracks, ties, mechanisms."""
