import type { Unit } from "./xliff.mjs";
export function pseudoUnits(units: readonly Unit[]): Unit[];
export function pseudoModule(): string;
