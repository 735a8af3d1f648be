"""What-if studies: designs of many runs, done by one or many processes, kept on disk, judged by statistics."""
