"""Whether an arm can change its posture without a singularity, exactly where that can be decided."""
