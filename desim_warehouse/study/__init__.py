"""What-if studies: a design of many runs, carried out by one or many processes, kept on disk, judged by statistics."""
