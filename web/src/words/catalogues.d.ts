/** The catalogues of `locales/`, as `catalogue/plugin.mjs` gives them. */
declare module "virtual:catalogues" {
  interface Words {
    // eslint-disable-next-line @typescript-eslint/consistent-type-imports -- a declared module may import nothing
    readonly templates: Readonly<Record<string, import("@lit/localize").LocaleModule["templates"][string]>>;
  }
  export const catalogues: Readonly<Record<string, { readonly first: () => Promise<Words>; readonly rest: () => Promise<Words> }>>;
}
