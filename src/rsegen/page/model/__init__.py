"""The model of the page: a document with its history, file and journal, and the actions that change it."""
