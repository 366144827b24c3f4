"""Steps in time: methods as short sequences of calls of emitted functions, certified as everything else."""
