"""What is compared: the description of ports and routines, the Fortran's text, and inputs."""
