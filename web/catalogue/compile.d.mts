import type { Unit } from "./xliff.mjs";
export function compileCatalogue(units: readonly (Unit | undefined)[], wanted?: (id: string) => boolean): string;
