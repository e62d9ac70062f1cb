"""What ./bpc does before the product starts; standard library only."""
