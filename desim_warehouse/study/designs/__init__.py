"""The best of more designs than can be raced: a search among them, judged on days that it did not use."""
