"""A trained scene in use: its files, its lights, pictures, films and exports."""
