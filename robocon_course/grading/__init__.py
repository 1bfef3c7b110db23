"""Other people's notebooks: read without being run, judged in processes of their own."""
