"""What an answer is: its value, its words and numbers, and how the terminal prints it. It knows no study."""
