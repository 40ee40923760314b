"""How kernels are compiled: decorators, vector instructions, threads."""
