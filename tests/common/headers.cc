// Nothing of its own: what it is built with are the headers that tests share.
