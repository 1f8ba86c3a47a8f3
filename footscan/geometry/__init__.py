"""Pure mathematics: rigid transforms and planes. Nothing here knows about cameras or feet."""
