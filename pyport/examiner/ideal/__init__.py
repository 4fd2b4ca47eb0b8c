"""What an observer who knows the form of a cause and the noise could see, and what a tool sees."""
