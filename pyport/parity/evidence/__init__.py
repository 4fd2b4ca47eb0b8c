"""That the comparison can fail: mutants, branches taken, builds, the simplest inputs."""
