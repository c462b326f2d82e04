export function allMessageIds(): Set<string>;
