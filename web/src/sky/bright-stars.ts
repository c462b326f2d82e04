/**
 * The stars brighter than third magnitude: what people call them, Bayer's letter, right ascension
 * and declination (°, J2000, epoch 2000), visual magnitude. Facts of the Hipparcos catalogue.
 */

export interface Star {
  readonly name: string;
  readonly bayer: string;
  readonly raDeg: number;
  readonly decDeg: number;
  readonly magnitude: number;
}

// Name|Bayer|right ascension|declination|magnitude, brightest first.
const ROWS = `
Sirius|α CMa|101.287|-16.716|-1.4
Canopus|α Car|95.988|-52.696|-0.6
Arcturus|α Boo|213.915|19.182|-0.1
Rigil Kentaurus|α1 Cen|219.902|-60.834|0.0
Vega|α Lyr|279.235|38.784|0.0
Capella|α Aur|79.172|45.998|0.1
Rigel|β Ori|78.635|-8.202|0.2
Procyon|α CMi|114.826|5.225|0.4
Achernar|α Eri|24.428|-57.237|0.5
Betelgeuse|α Ori|88.793|7.407|0.5
Hadar|β Cen|210.956|-60.373|0.6
Altair|α Aql|297.696|8.868|0.8
Acrux|α1 Cru|186.65|-63.099|0.8
Aldebaran|α Tau|68.98|16.509|0.9
Spica|α Vir|201.298|-11.161|1.0
Antares|α Sco|247.352|-26.432|1.1
Pollux|β Gem|116.329|28.026|1.2
Fomalhaut|α PsA|344.413|-29.622|1.2
Deneb|α Cyg|310.358|45.28|1.2
Mimosa|β Cru|191.93|-59.689|1.2
Toliman|α2 Cen|219.896|-60.837|1.4
Regulus|α Leo|152.093|11.967|1.4
Adhara|ε CMa|104.656|-28.972|1.5
Castor|α Gem|113.649|31.888|1.6
Gacrux|γ Cru|187.792|-57.113|1.6
Shaula|λ Sco|263.402|-37.104|1.6
Bellatrix|γ Ori|81.283|6.35|1.6
Elnath|β Tau|81.573|28.608|1.6
Miaplacidus|β Car|138.3|-69.717|1.7
Alnilam|ε Ori|84.053|-1.202|1.7
Alnair|α Gru|332.058|-46.961|1.7
Alnitak|ζ Ori|85.19|-1.943|1.7
Regor|γ2 Vel|122.383|-47.337|1.8
Alioth|ε UMa|193.507|55.96|1.8
Kaus Australis|ε Sgr|276.043|-34.385|1.8
Mirfak|α Per|51.081|49.861|1.8
Dubhe|α UMa|165.932|61.751|1.8
Wezen|δ CMa|107.098|-26.393|1.8
Alkaid|η UMa|206.885|49.313|1.9
Avior|ε Car|125.629|-59.51|1.9
Sargas|θ Sco|264.33|-42.998|1.9
Menkalinan|β Aur|89.882|44.947|1.9
Atria|α TrA|252.166|-69.028|1.9
Alhena|γ Gem|99.428|16.399|1.9
Alsephina|δ Vel|131.176|-54.709|1.9
Peacock|α Pav|306.412|-56.735|1.9
Polaris|α UMi|37.955|89.264|2.0
Mirzam|β CMa|95.675|-17.956|2.0
Alphard|α Hya|141.897|-8.659|2.0
Algieba|γ1 Leo|154.993|19.841|2.0
Hamal|α Ari|31.793|23.462|2.0
Diphda|β Cet|10.897|-17.987|2.0
Nunki|σ Sgr|283.816|-26.297|2.0
Menkent|θ Cen|211.671|-36.37|2.1
Alpheratz|α And|2.097|29.09|2.1
Kochab|β UMi|222.676|74.156|2.1
Mirach|β And|17.433|35.621|2.1
Saiph|κ Ori|86.939|-9.67|2.1
Tiaki|β Gru|340.667|-46.885|2.1
Rasalhague|α Oph|263.734|12.56|2.1
Algol|β Per|47.042|40.956|2.1
Almach|γ1 And|30.975|42.33|2.1
Denebola|β Leo|177.265|14.572|2.1
Navi|γ Cas|14.177|60.717|2.1
Muhlifain|γ Cen|190.379|-48.96|2.2
Aspidiske|ι Car|139.273|-59.275|2.2
Naos|ζ Pup|120.896|-40.003|2.2
Alphecca|α CrB|233.672|26.715|2.2
Mizar|ζ UMa|200.981|54.925|2.2
Sadr|γ Cyg|305.557|40.257|2.2
Suhail|λ Vel|136.999|-43.433|2.2
Eltanin|γ Dra|269.151|51.489|2.2
Shedar|α Cas|10.127|56.537|2.2
Mintaka|δ Ori|83.002|-0.299|2.2
Caph|β Cas|2.295|59.15|2.3
ε Cen|ε Cen|204.972|-53.466|2.3
Dschubba|δ Sco|240.083|-22.622|2.3
Larawag|ε Sco|252.541|-34.293|2.3
Men|α Lup|220.482|-47.388|2.3
η Cen|η Cen|218.877|-42.158|2.3
Merak|β UMa|165.46|56.382|2.3
Izar|ε Boo|221.247|27.074|2.4
Enif|ε Peg|326.046|9.875|2.4
Mula|κ Sco|265.622|-39.03|2.4
Ankaa|α Phe|6.571|-42.306|2.4
Phecda|γ UMa|178.458|53.695|2.4
Sabik|η Oph|257.594|-15.725|2.4
Scheat|β Peg|345.944|28.083|2.4
Alderamin|α Cep|319.645|62.586|2.5
Aludra|η CMa|111.024|-29.303|2.5
Markeb|κ Vel|140.528|-55.011|2.5
Aljanah|ε Cyg|311.553|33.97|2.5
Markab|α Peg|346.19|15.205|2.5
Menkar|α Cet|45.57|4.09|2.5
Saik|ζ Oph|249.29|-10.567|2.5
Alnair|ζ Cen|208.885|-47.288|2.5
Acrab|β1 Sco|241.359|-19.805|2.6
Zosma|δ Leo|168.527|20.524|2.6
δ Cen|δ Cen|182.09|-50.722|2.6
Arneb|α Lep|83.183|-17.822|2.6
Gienah|γ Crv|183.952|-17.542|2.6
Ascella|ζ Sgr|285.653|-29.88|2.6
Zubeneschamali|β Lib|229.252|-9.383|2.6
Unukalhai|α Ser|236.067|6.426|2.6
Sheratan|β Ari|28.66|20.808|2.6
Kraz|β Crv|188.597|-23.397|2.6
Mahasim|θ Aur|89.93|37.213|2.6
Phact|α Col|84.912|-34.074|2.6
Ruchbah|δ Cas|21.454|60.235|2.7
KeKouan|β Lup|224.633|-43.134|2.7
Muphrid|η Boo|208.671|18.398|2.7
α Mus|α Mus|189.296|-69.136|2.7
μ Vel|μ Vel|161.692|-49.42|2.7
Hassaleh|ι Aur|74.248|33.166|2.7
Lesath|υ Sco|262.691|-37.296|2.7
π Pup|π Pup|109.286|-37.097|2.7
Kaus Media|δ Sgr|275.249|-29.828|2.7
Tarazed|γ Aql|296.565|10.613|2.7
Athebyne|η Dra|245.998|61.514|2.7
Yed Prior|δ Oph|243.586|-3.694|2.7
θ Car|θ Car|160.739|-64.394|2.7
Porrima|γ Vir|190.415|-1.449|2.7
ι Cen|ι Cen|200.149|-36.712|2.8
Hatysa|ι Ori|83.858|-5.91|2.8
Zubenelgenubi|α2 Lib|222.72|-16.042|2.8
Cebalrai|β Oph|265.868|4.567|2.8
Cursa|β Eri|76.962|-5.086|2.8
Kornephoros|β Her|247.555|21.49|2.8
Rasalgethi|α1 Her|258.662|14.39|2.8
Imai|δ Cru|183.786|-58.749|2.8
Rastaban|β Dra|262.608|52.301|2.8
γ Lup|γ Lup|233.785|-41.167|2.8
Nihal|β Lep|82.061|-20.759|2.8
Rutilicus|ζ Her|250.322|31.603|2.8
β Hyi|β Hyi|6.438|-77.254|2.8
Kaus Borealis|λ Sgr|276.993|-25.422|2.8
Paikauhale|τ Sco|248.971|-28.216|2.8
β TrA|β TrA|238.786|-63.431|2.8
Algenib|γ Peg|3.309|15.184|2.8
Tureis|ρ Pup|121.886|-24.304|2.8
β Ara|β Ara|261.325|-55.53|2.8
Atik|ζ Per|58.533|31.884|2.8
Choo|α Ara|262.96|-49.876|2.8
Alcyone|η Tau|56.871|24.105|2.9
Deneb Algedi|δ Cap|326.76|-16.127|2.9
Vindemiatrix|ε Vir|195.544|10.959|2.9
α Hyi|α Hyi|29.692|-61.57|2.9
Fawaris|δ Cyg|296.244|45.131|2.9
α Tuc|α Tuc|334.625|-60.26|2.9
γ TrA|γ TrA|229.727|-68.68|2.9
Tejat|μ Gem|95.74|22.514|2.9
Acamar|θ1 Eri|44.565|-40.305|2.9
Albaldah|π Sgr|287.441|-21.024|2.9
Cor Caroli|α2 CVn|194.007|38.318|2.9
Fang|π Sco|239.713|-26.114|2.9
Gomeisa|β CMi|111.788|8.289|2.9
ε Per|ε Per|59.464|40.01|2.9
Alniyat|σ Sco|245.297|-25.593|2.9
Sadalsuud|β Aqr|322.89|-5.571|2.9
γ Per|γ Per|46.199|53.506|2.9
υ Car|υ Car|146.775|-65.072|2.9
Matar|η Peg|340.751|30.221|2.9
τ Pup|τ Pup|102.484|-50.615|2.9
Algorab|δ Crv|187.466|-16.515|2.9
Sadalmelik|α Aqr|331.446|-0.32|3.0
Algenubi|ε Leo|146.463|23.774|3.0
Tianguan|ζ Tau|84.411|21.142|3.0
Zaurak|γ Eri|59.507|-13.508|3.0
Alnasl|γ2 Sgr|271.452|-30.424|3.0
γ Hya|γ Hya|199.73|-23.172|3.0
Girtab|ι1 Sco|266.896|-40.127|3.0
Okab|ζ Aql|286.353|13.864|3.0
ψ UMa|ψ UMa|167.416|44.498|3
Aldhanab|γ Gru|328.482|-37.365|3
Mizan|β Tri|32.386|34.987|3
Pherkad|γ UMi|230.182|71.834|3
Xamidimura|μ1 Sco|252.968|-38.047|3
`;

export const STARS: readonly Star[] = ROWS.trim()
  .split("\n")
  .map((row) => {
    const [name = "", bayer = "", ra = "", dec = "", magnitude = ""] = row.split("|");
    return { name, bayer, raDeg: Number(ra), decDeg: Number(dec), magnitude: Number(magnitude) };
  });
