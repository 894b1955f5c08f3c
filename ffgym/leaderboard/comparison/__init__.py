"""Who is where: samples of rows, intervals by bootstrap, scores, ranks and ties."""
