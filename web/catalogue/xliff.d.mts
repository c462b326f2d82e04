export type Part = string | { readonly id: string; readonly text: string };
export interface Unit {
  readonly id: string;
  readonly source: readonly Part[];
  readonly target: readonly Part[] | null;
  readonly note: string;
}
export function languages(): string[];
export function readCatalogue(language: string): Unit[];
export function unitsOf(xml: string): Unit[];
export function plainText(parts: readonly Part[]): string;
export function idFault(unit: Unit): string;
export function faultOf(source: readonly Part[] | undefined, text: string): string;
export function fillCatalogue(xml: string, translations: Readonly<Record<string, string>>): string;
