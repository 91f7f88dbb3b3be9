"""The program over joints by an interior-point method: one joint, all joints, the iteration, and stability."""
