/** A WebSocket with the hub's end in the test's hand. */

import { Decoder, Encoder } from "@msgpack/msgpack";

export class FakeSocket {
  binaryType: BinaryType = "blob";
  readyState = 1;
  bufferedAmount = 0;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  onclose: (() => void) | null = null;
  onopen: (() => void) | null = null;
  readonly sent: Record<string, unknown>[] = [];
  closed = false;

  send(bytes: Uint8Array): void {
    this.sent.push(new Decoder().decode(bytes) as Record<string, unknown>);
  }

  close(): void {
    this.closed = true;
    this.readyState = 3;
  }

  /** The hub says something. */
  say(message: object): void {
    this.onmessage?.({ data: new Encoder().encode(message).slice().buffer });
  }

  /** The hub, or the network, is gone. */
  die(): void {
    this.readyState = 3;
    this.onclose?.();
  }

  greet(): void {
    this.say({ t: "greeting", who: "ana", role: "operator", time_us: 0 });
  }

  tags(): unknown[] {
    return this.sent.map((message) => message["t"]);
  }
}
