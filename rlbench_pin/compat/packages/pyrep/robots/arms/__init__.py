"""Arms. The catalogue has one, the Panda; the names of others say so when they are used."""
