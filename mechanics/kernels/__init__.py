"""The compiled loops: each is the only source of its loop.

Functions here may have more arguments, and more lines, than elsewhere. Arrays are passed one by one: numba compiles a
function once more for each type of its arguments, and every other tuple of arrays would be another type. A loop is not
divided where its stages share the arrays that it has allocated.
"""
