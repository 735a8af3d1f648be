"""Studies of what-if questions: designs of many runs, in one or many processes, kept on disk, judged by statistics."""
