/** Reads what ROS serialized: CDR of ROS 2, and ROS 1's own form. Pure. */

import { msg, str } from "@lit/localize";

/** Bytes that are no such message. */
export class MessageError extends Error {}

/** Longer lists than a message of this size can hold are not believed. */
const ENCAPSULATION = 4;
/** Letters of a short text. */
const SHORT = 40;
const decoder = new TextDecoder();

export class MessageReader {
  readonly ros1: boolean;
  private readonly view: DataView;
  private readonly little: boolean;
  private at: number;

  /** @param encoding `cdr` (with its header of four bytes) or `ros1` */
  constructor(
    readonly bytes: Uint8Array,
    encoding: string,
  ) {
    this.ros1 = encoding === "ros1";
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    if (!this.ros1 && (bytes.length < ENCAPSULATION || bytes[0] !== 0 || (bytes[1] ?? 9) > 1)) throw new MessageError(msg("not in plain CDR"));
    this.little = this.ros1 || bytes[1] === 1;
    this.at = this.ros1 ? 0 : ENCAPSULATION;
  }

  uint8(): number {
    return this.view.getUint8(this.step(1));
  }

  bool(): boolean {
    return this.uint8() !== 0;
  }

  int32(): number {
    return this.view.getInt32(this.step(4), this.little);
  }

  uint32(): number {
    return this.view.getUint32(this.step(4), this.little);
  }

  float32(): number {
    return this.view.getFloat32(this.step(4), this.little);
  }

  float64(): number {
    return this.view.getFloat64(this.step(8), this.little);
  }

  text(): string {
    const raw = this.rawBytes(this.uint32());
    // In CDR a zero closes it.
    const end = raw.length > 0 && raw[raw.length - 1] === 0 ? raw.length - 1 : raw.length;
    return shortText(raw, end) ?? decoder.decode(raw.subarray(0, end));
  }

  /** How many entries follow, each of at least `least` bytes. */
  length(least: number): number {
    const count = this.uint32();
    if (count * least > this.bytes.length - this.at) throw new MessageError(msg(str`${String(count)} entries in ${String(this.bytes.length)} bytes`));
    return count;
  }

  list<T>(least: number, read: () => T): T[] {
    const count = this.length(least);
    const found: T[] = [];
    for (let i = 0; i < count; i++) found.push(read());
    return found;
  }

  float32s(): Float32Array {
    const count = this.length(4);
    const found = new Float32Array(count);
    for (let i = 0; i < count; i++) found[i] = this.float32();
    return found;
  }

  float64s(): number[] {
    return this.list(8, () => this.float64());
  }

  /** `uint8[]` or `int8[]` as they lie there. */
  octets(): Uint8Array {
    return this.rawBytes(this.uint32());
  }

  skip(count: number, size: number): void {
    for (let i = 0; i < count; i++) this.step(size);
  }

  private rawBytes(count: number): Uint8Array {
    if (count > this.bytes.length - this.at) throw new MessageError(msg("it ends too early"));
    const begin = this.at;
    this.at += count;
    return this.bytes.subarray(begin, this.at);
  }

  private step(size: number): number {
    // A number begins at a multiple of its size, counted from behind the header.
    if (!this.ros1) this.at += (size - ((this.at - ENCAPSULATION) % size)) % size;
    const begin = this.at;
    this.at += size;
    if (this.at > this.bytes.length) throw new MessageError(msg("it ends too early"));
    return begin;
  }
}

/** Names of frames come by the thousand a second, and a decoder takes its time for each; null of what is long, or not plain ASCII. */
function shortText(raw: Uint8Array, end: number): string | null {
  if (end > SHORT) return null;
  let text = "";
  for (let i = 0; i < end; i++) {
    const letter = raw[i] ?? 0;
    if (letter > 127) return null;
    text += String.fromCharCode(letter);
  }
  return text;
}
