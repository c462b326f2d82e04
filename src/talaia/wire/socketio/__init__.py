"""Engine.IO 3 and 4, and Socket.IO over them, as clients of both generations speak them.

The texts are ``engine.io-protocol`` (revisions 3 and 4) and ``socket.io-protocol`` (revisions 2
to 5) of the Socket.IO project. Engine.IO carries packets over polled HTTP requests or a WebSocket;
Socket.IO carries events of namespaces, with bytes as packets of their own behind an event.
"""
