/** One of two texts by a number, as the language has it. */

export function plural<T>(many: number, one: T, other: T): T {
  return many === 1 ? one : other;
}
