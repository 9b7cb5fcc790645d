"""A network that loses, doubles and delays packets, between a controller and its client."""

import select
import socket
import threading

import numpy as np


class Lossy:
    """Passes datagrams on; a share of them is lost, another doubled, another late by one."""

    def __init__(self, client, share, seed=1):
        self.lost = self.doubled = self.late = 0
        self._share, self._rng = share, np.random.default_rng(seed)
        self._client, self._controller = client, None
        self._front = self._socket()
        self._back = self._socket()
        self._held = {self._front: None, self._back: None}
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._pass_on)

    @property
    def address(self):
        """Where the controller sends to."""
        return self._front.getsockname()

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._front.close()
        self._back.close()

    @staticmethod
    def _socket():
        udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        udp.bind(("127.0.0.1", 0))
        return udp

    def _pass_on(self):
        while not self._stop.is_set():
            for udp in select.select([self._front, self._back], [], [], 0.01)[0]:
                datagram, sender = udp.recvfrom(65535)
                if udp is self._front:
                    self._controller = sender
                    self._send(datagram, udp, self._back, self._client)
                else:
                    self._send(datagram, udp, self._front, self._controller)

    def _send(self, datagram, source, udp, to):
        draw, share = self._rng.random(), self._share
        if draw < share:
            self.lost += 1
            return
        if draw < 2 * share:
            self.late += 1
            self._held[source] = datagram
            return
        udp.sendto(datagram, to)
        if draw < 3 * share:
            self.doubled += 1
            udp.sendto(datagram, to)
        if self._held[source] is not None:
            udp.sendto(self._held[source], to)
            self._held[source] = None
