"""Read and write the files of users: calibrations and parameters."""
