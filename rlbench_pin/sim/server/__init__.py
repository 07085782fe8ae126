"""What belongs to a physics server: the calls that built it, what it prints, and the memory it leaves behind."""
