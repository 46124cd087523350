"""What several tests share: data made up by code, and fixtures."""
